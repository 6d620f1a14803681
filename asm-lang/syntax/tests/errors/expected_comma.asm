asm expected_comma
signature:
definitions:
  main rule r_Main = a := max(b c) //~ L058
