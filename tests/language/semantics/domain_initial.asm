// a dynamic domain gets its elements in the initial state
asm domain_initial
import StandardLibrary
signature:
  dynamic domain Small subsetof Integer
  controlled f: Small -> Integer
definitions:
  main rule r_Main = forall $s in Small do f($s) := $s
default init s0:
  domain Small = {1, 2}
//= step 1: f(1) := 1, f(2) := 2
