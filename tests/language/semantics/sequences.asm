// positions count from 0
asm sequences
import StandardLibrary
signature:
  controlled s: Seq(Integer)
  controlled t: Seq(Integer)
  controlled x: Integer
  controlled n: Integer
definitions:
  main rule r_Main = par
    s := append([1, 2], 3)
    t := tail(union([1], [2, 1]))
    x := at([5, 6], 1n)
    n := length([1, 1])
  endpar
//= step 1: n := 2, s := [1,2,3], t := [2,1], x := 6
