// functions local to a turbo rule: initialised at once, forgotten afterwards, each call has its own
asm local_functions
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
definitions:
  turbo rule r_sum($n in Integer) in Integer =
    local total: Integer [ total := 0 ]
    local seen: Integer -> Boolean [ forall $i in {1 : 3} do seen($i) := $i = 2 ]
    if $n = 0 then result := 0
    else seq
      total <- r_sum($n - 1)
      if seen(2) and not seen(1) then total := total + $n endif
      result := total
    endseq endif
  main rule r_Main = par
    x <- r_sum(4)
    y <- r_sum(2)
  endpar
//= step 1: x := 10, y := 3
