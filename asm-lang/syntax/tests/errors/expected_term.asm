asm expected_term
signature:
definitions:
  main rule r_Main = a := 1 + * 2 //~ L058
