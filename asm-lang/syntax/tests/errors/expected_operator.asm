asm expected_operator
signature:
definitions:
  function f = 1 2 //~ L058
