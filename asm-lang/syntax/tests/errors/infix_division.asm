asm infix_division
signature:
definitions:
  rule r_a =
    par
      n := n div 2 //~ L078
      m := (n + 1) div n //~ L078
      k := f(n) + n div 3 //~ L078
    endpar
  rule r_b = par n := div(n, 2) div := n div(1) := n endpar
  main rule r_Main = skip
