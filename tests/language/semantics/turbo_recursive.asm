// calls itself for its result
asm turbo_recursive
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  turbo rule r_factorial($n in Integer) in Integer =
    if $n <= 1 then result := 1
    else seq result <- r_factorial($n - 1)  result := result * $n endseq endif
  main rule r_Main = x <- r_factorial(5)
//= step 1: x := 120
