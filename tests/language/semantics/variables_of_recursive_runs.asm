// every run of a rule has variables of its own
asm variables_of_recursive_runs
import StandardLibrary
signature:
  controlled f: Integer
definitions:
  turbo rule r_fib($n in Integer) in Integer =
    if $n < 2 then result := $n
    else let ($a = 0, $b = 0) in seq
      $a <- r_fib($n - 1)
      $b <- r_fib($n - 2)
      result := $a + $b
    endseq endlet endif
  main rule r_Main = f <- r_fib(10)
//= step 1: f := 55
