asm expected_domain
signature:
definitions:
  rule r_a($x in 5) = skip //~ L058
