asm bare_point
signature:
definitions:
  main rule r_Main = a := 1. //~ L008
