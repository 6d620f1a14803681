// a value for each key
asm maps
import StandardLibrary
signature:
  controlled m: Map(String, Integer)
  controlled x: Integer
  controlled y: Integer
definitions:
  main rule r_Main = par m := {"a" -> 1, "b" -> 2}  x := at({"a" -> 1}, "a")  y := at({"a" -> 1}, "c") endpar
//= step 1: m := {"a"->1,"b"->2}, x := 1, y := undef
