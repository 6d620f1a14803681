// it may apply itself
asm static_recursive
import StandardLibrary
signature:
  static fib: Integer -> Integer
  controlled x: Integer
definitions:
  function fib($n in Integer) = if $n < 2 then $n else fib($n - 1) + fib($n - 2) endif
  main rule r_Main = x := fib(12)
//= step 1: x := 144
