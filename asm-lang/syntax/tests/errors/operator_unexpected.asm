asm operator_unexpected
signature:
definitions:
  main rule r_Main =
    par
      a + 1 //~ L058
      b := 2
    endpar
