asm several_rules_in_declaration
signature:
definitions:
  rule r_a =
    a := 1
    b := 2 //~ L034
  main rule r_Main = skip
