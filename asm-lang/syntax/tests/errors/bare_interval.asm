asm bare_interval
signature:
definitions:
  rule r_a = forall $i in 1..5 do f($i) := 1 //~ L079
  rule r_b = n := 1..5 //~ L079
  main rule r_Main = choose $i in {1 : 5} with $i > 1..2 do skip //~ L079
