asm bracketed_rule
signature:
definitions:
  main rule r_Main =
    (a := 1) //~ L036
