// natural numbers and integers are the same in collections and tuples, too
asm equality_of_wholes
import StandardLibrary
signature:
  domain Small subsetof Natural
  controlled ns: Seq(Natural)
  controlled ms: Seq(Integer)
  controlled s: Seq(Boolean)
definitions:
  domain Small = {0n : 3n}
  main rule r_Main = s := [
    ns = ms,
    ns != ms,
    {1n, 2n} = {2, 1},
    (1n, "a") = (1, "a"),
    {1n -> 2} = {1 -> 2n},
    <1n, 1n> = <1, 1>,
    [(1n, {2n})] = [(1, {2})],
    {1n : 3n} = {1 : 4}
  ]
default init s0:
  function ns = [1n, 2n]
  function ms = [1, 2]
//= step 1: s := [true,false,true,true,true,true,true,false]
