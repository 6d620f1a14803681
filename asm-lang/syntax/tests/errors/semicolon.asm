asm semicolon
signature:
definitions:
  main rule r_Main =
    par
      a := 1; //~ L010
      b := 2;
    endpar
