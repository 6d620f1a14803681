asm missing_do_while
signature:
definitions:
  main rule r_Main =
    while a < 3 a := a + 1 //~ L052
