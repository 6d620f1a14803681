asm braces_around_rules
signature:
definitions:
  main rule r_Main = { a := 1 } //~ L036
