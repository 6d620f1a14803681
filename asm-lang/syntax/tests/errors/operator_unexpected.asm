asm operator_unexpected
signature:
definitions:
  main rule r_Main =
    par
      a + 1 //~ L038
      b := 2
    endpar
