asm comprehension_without_term
signature:
definitions:
  function a = {$x in d | p($x)} //~ L066
  function b = { $x in d } //~ L066
  function c = [$x in {1 : 3} | $x > 2] //~ L066
  function e = {$x in d, $y in d | $x = $y } //~ L066
  main rule r_Main = skip
