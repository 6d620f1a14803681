// a static function is its definition
asm static
import StandardLibrary
signature:
  static twice: Integer -> Integer
  static limit: Integer
  controlled x: Integer
definitions:
  function twice($n in Integer) = 2 * $n
  function limit = twice(21)
  main rule r_Main = x := limit
//= step 1: x := 42
