asm no_rule_in_declaration
signature:
definitions:
  rule r_a =
  main rule r_Main = skip //~ L035
