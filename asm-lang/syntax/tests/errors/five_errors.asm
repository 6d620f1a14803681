asm five_errors
signature:
definitions:
  function f = 1 +
  function g = {1, 2 //~ L038
  rule r_1 = a = 1 //~ L021 L030
  rule r_2 = if a then b := 1
  rule r_3 = par a := 1 b = 2 endpar //~ L021 L030
  main rule r_Main = skip
