asm many_calls
import StandardLibrary
signature:
  static count: Integer -> Integer
  controlled x: Integer
definitions:
  function count($n in Integer) = if $n = 0 then 1 else count($n - 1) + count($n - 1) endif  //~ R021
  main rule r_Main = x := count(100)
