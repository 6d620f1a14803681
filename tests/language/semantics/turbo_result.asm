// the value of `result` goes where the call says, and nowhere else
asm turbo_result
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
definitions:
  turbo rule r_square($n in Integer) in Integer = result := $n * $n
  main rule r_Main = par x <- r_square(3)  y <- r_square(4) endpar
//= step 1: x := 9, y := 16
