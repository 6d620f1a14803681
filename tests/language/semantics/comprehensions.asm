// of sets, sequences, bags and maps
asm comprehensions
import StandardLibrary
signature:
  controlled s: Powerset(Integer)
  controlled q: Seq(Integer)
  controlled m: Map(Integer, Integer)
  controlled b: Bag(Integer)
definitions:
  main rule r_Main = par
    s := {$a in {1 : 4} | $a mod 2 = 0 : $a * $a}
    q := [$a in [3, 1] : $a + 1]
    m := {$a in {1, 2} : $a -> $a * 10}
    b := <$a in <1, 1, 2> | $a < 2 : $a>
  endpar
//= step 1: b := <1,1>, m := {1->10,2->20}, q := [4,2], s := {16,4}
