asm compound_assignment
signature:
definitions:
  rule r_a =
    par
      n++ //~ L077
      n -- //~ L077
      f($x) += 2 * n //~ L077
      f(n) -= 1 //~ L077
      n++ m := 1 //~ L077
      m := n - -1
      m := n --1
      m := n ++ k
    endpar
  main rule r_Main = if n > 0 then n *= 2 //~ L077
    else m-- endif //~ L077
