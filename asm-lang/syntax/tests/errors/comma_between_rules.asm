asm comma_between_rules
signature:
definitions:
  main rule r_Main =
    par
      a := 1, //~ L040
      b := 2
    endpar
