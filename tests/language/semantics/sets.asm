// elements in any order, each once
asm sets
import StandardLibrary
signature:
  controlled s: Powerset(Integer)
  controlled t: Powerset(Integer)
  controlled n: Integer
  controlled b: Boolean
definitions:
  main rule r_Main = par
    s := union({3, 1}, {1, 2})
    t := difference({1, 2}, {2, 3})
    n := size(intersection({1, 2}, {2, 3}))
    b := contains({1, 2}, 2) and {1, 2} = {2, 1} and notin({1}, 2)
  endpar
//= step 1: b := true, n := 1, s := {1,2,3}, t := {1}
