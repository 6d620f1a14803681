asm missing_equals_of_rule
signature:
definitions:
  rule r_a a := 1 //~ L052
  main rule r_Main = skip
