// of functions with one name, the arguments pick
asm overloads
import StandardLibrary
signature:
  controlled f: Integer -> Integer
  controlled f: String -> Integer
  controlled f: Integer
definitions:
  main rule r_Main = par f(1) := 1  f("a") := 2  f := 3 endpar
//= step 1: f := 3, f("a") := 2, f(1) := 1
