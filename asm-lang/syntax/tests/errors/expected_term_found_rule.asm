asm expected_term_found_rule
signature:
definitions:
  main rule r_Main = a := skip //~ L058
