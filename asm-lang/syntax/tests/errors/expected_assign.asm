asm expected_assign
signature:
definitions:
  main rule r_Main = a + 1 //~ L058
