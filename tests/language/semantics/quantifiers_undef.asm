// undef stays undef unless another element decides
asm quantifiers_undef
import StandardLibrary
signature:
  controlled f: Integer -> Integer
  controlled a: Boolean
  controlled b: Boolean
  controlled c: Boolean
definitions:
  main rule r_Main = par
    a := (forall $n in {1 : 2} with f($n) > 0)
    b := (exists $n in {1 : 2} with f($n) > 0)
    c := (forall $n in {1 : 2} with f($n) > 1)
  endpar
default init s0:
  function f($n in Integer) = if $n = 1 then 1 endif
//= step 1: a := undef, b := true, c := false
