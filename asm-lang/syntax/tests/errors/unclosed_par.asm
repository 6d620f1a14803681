asm unclosed_par
signature:
definitions:
  rule r_a =
    par
      a := 1
      b := 2
  rule r_b = skip //~ L031
