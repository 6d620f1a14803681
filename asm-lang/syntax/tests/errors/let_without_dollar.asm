asm let_without_dollar
signature:
definitions:
  rule r_a = let x = f(y), z = 2 in par a := x + z b := x(z) let x = x in b := x endlet endpar endlet //~ L065
  rule r_b = let x = 1, y = x in a := y endlet //~ L065
  rule r_c = let x = 1 in a := x //~ L065
