asm let_without_brackets
signature:
definitions:
  function f = let $x = 1 in $x endlet //~ L065
  rule r_a = let $x = f({$y in d : $y}) in a := $x endlet //~ L065
  rule r_b = let $x = 1, $y = (let ($z = 2) in $z endlet) in a := $x endlet //~ L065
  rule r_c = let x = 1 in a := x endlet //~ L065
  main rule r_Main = let $x := 1 in skip endlet //~ L065
