// three values: the connectives of Kleene
asm undef_logic
import StandardLibrary
signature:
  controlled u: Boolean
  controlled a: Boolean
  controlled b: Boolean
  controlled c: Boolean
  controlled d: Boolean
  controlled e: Boolean
  controlled f: Boolean
  controlled h: Boolean
definitions:
  main rule r_Main = par
    a := u and false
    b := true or u
    c := u or false
    d := false implies u
    e := u implies true
    f := not u
    h := u iff u
  endpar
//= step 1: a := false, b := true, c := undef, d := true, e := true, f := undef, h := undef
