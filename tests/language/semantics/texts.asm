// texts are kept as written
asm texts
import StandardLibrary
signature:
  controlled s: String
  controlled t: String
  controlled n: Integer
definitions:
  main rule r_Main = par s := "a" + "b"  t := toString(12)  n := size("abc") endpar
//= step 1: n := 3, s := "ab", t := "12"
