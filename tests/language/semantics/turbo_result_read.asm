// within the rule, `result` can be read like a location
asm turbo_result_read
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  turbo rule r_sum($n in Integer) in Integer = seq result := 0  forall $i in {1 : 1} do result := result + $n  result := result + 1 endseq
  main rule r_Main = x <- r_sum(4)
//= step 1: x := 5
