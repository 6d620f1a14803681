// components by position
asm tuples
import StandardLibrary
signature:
  controlled p: Prod(Integer, String)
  controlled s: String
  controlled b: Boolean
definitions:
  main rule r_Main = par p := (1, "a")  s := second((1, "b"))  b := (1, 2) = (1, 2) endpar
//= step 1: b := true, p := (1,"a"), s := "b"
