// inputs may be sets, tuples and texts
asm monitored_collections
import StandardLibrary
signature:
  monitored s: Powerset(Integer)
  monitored p: Prod(Integer, String)
  controlled n: Integer
  controlled t: String
definitions:
  main rule r_Main = par n := size(s)  t := second(p) endpar
//? step 1: s = {1,2,3}, p = (1,"a b")
//= step 1: n := 3, t := "a b"
