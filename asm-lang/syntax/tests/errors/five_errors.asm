asm five_errors
signature:
definitions:
  function f = 1 +
  function g = {1, 2 //~ L058
  rule r_1 = a = 1 //~ L031 L050
  rule r_2 = if a then b := 1
  rule r_3 = par a := 1 b = 2 endpar //~ L031 L050
  main rule r_Main = skip
