asm rules
signature:
definitions:
rule r_basic = par x:=1 f(x,2) := undef r_call[] r_turbo( 1 ,2) $r[x] program(self) x<-r_turbo(1) self.f := 2 endpar
rule r_block =
  par   // both at once

    x := 1

    // the second one
    y := 2
    seq skip skip endseq
    // nothing more
  endpar
rule r_if =
  par
    if a then skip endif
    if a then skip else x := 1 endif
    if a then
      skip
    else if b then x := 1
    else x := 2 endif endif
    if a then
      skip
    // what if not
    else // so
      if b then skip endif
    endif
    if (someLongConditionOfTheState and anotherLongConditionOfTheState and aThirdLongCondition) then skip endif
  endpar
rule r_switch = switch x case 1 : skip
    // two
    case 2:
      skip
    case 3: if a then
       skip endif
    otherwise skip
  endswitch
rule r_choose = choose $x in D, $y in E with f($x)>0 do x := $x ifnone skip
rule r_choose_long = choose $robot in Robot, $task in Task with not busy($robot) and not lowBattery($robot) and pending($task) do par busy($robot) := true endpar ifnone skip
rule r_forall = forall $x in D with true do
    f($x) := 1
rule r_let = let ($x=1,$y=$x+1) in x := $x endlet
rule r_let_lines = let ($x = 1) in
    x := $x
  endlet
rule r_extend = extend D with $a,$b do par f($a) := 1 f($b) := 2 endpar
rule r_while = while x<10 do x := x+1
rule r_iterate = iterate
  x := x+1 enditerate
turbo rule r_local = local f: Integer [ f:=1 ] local g: D->E [skip] x := f
rule r_update = par
  x := if a then 1 else 2 endif
  x := if a then
    1 else 2 endif
  x := switch y case 1: 2 otherwise
    3 endswitch
  theSum($index) := someFunctionWithALongName($index) + anotherFunctionWithALongName($index) * 2
  theSet := {someFunctionWithALongName(1), someFunctionWithALongName(2), someFunctionWithALongName(3)}
  theMap := {1->2,3->4}
  some := {$x in D,$y in E|$x>$y:($x,$y)}
  endpar
main rule r_Main = skip
