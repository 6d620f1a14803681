asm misnamed_rule
signature:
definitions:
  rule a = skip //~ L056
