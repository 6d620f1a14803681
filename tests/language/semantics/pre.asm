// `pre` shows what a location held before the step, also within `seq`
asm pre
import StandardLibrary
signature:
  dynamic abstract domain Thing
  controlled x: Integer
  controlled y: Integer
  controlled f: Integer -> Integer
  controlled s: Seq(Integer)
  derived double: Integer
definitions:
  function double = x * 2
  main rule r_Main = seq
    x := x + 1
    f(1) := x
    extend Thing with $t do skip
    x := x + 10
    y := pre(x) + pre(pre(double))
    s := [x, pre(x), double, pre(double), size(Thing), pre(size(Thing)), pre(f(1)), x]
  endseq
default init s0:
  function x = 5
  function f($i in Integer) = 7
//= step 1: x := 16, f(1) := 6, Thing + {thing!1}, y := 15, s := [16,5,32,10,1,0,7,16]
//= step 2: x := 27, f(1) := 17, Thing + {thing!2}, y := 48, s := [27,16,54,32,2,1,6,27]
