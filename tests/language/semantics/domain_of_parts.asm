// the parts of a value are in the domains of the codomain, or undef; 4 is not in Few
asm domain_of_parts
import StandardLibrary
signature:
  domain Few subsetof Integer
  domain Small subsetof Integer
  monitored m: Integer
  monitored act: Integer
  controlled bag: Bag(Few)
  controlled row: Seq(Few)
  controlled set: Powerset(Few)
  controlled map: Map(Few, Small)
  controlled pair: Prod(Small, Few)
  controlled deep: Seq(Map(Integer, Powerset(Prod(Few, String))))
  controlled at: Integer -> Seq(Small)
definitions:
  domain Few = {3, 5, 7}
  domain Small = {1 : 3}
  main rule r_Main = switch act
    case 1: bag := <3, m>
    case 2: row := [3, m]
    case 3: set := {3, m}
    case 4: map := {m -> 1}
    case 5: map := {3 -> m}
    case 6: pair := (1, m)
    case 7: pair := (m, 3)
    case 8: deep := [{4 -> {(m, "a")}}]
    case 9: at(m) := [1, m]
    case 10: seq bag := <m> bag := <3> endseq
  endswitch
//? step 1: act = 1, m = 5
//= step 1: bag := <3,5>
//? step 2: act = 2, m = 7
//= step 2: row := [3,7]
//? step 3: act = 3, m = 7
//= step 3: set := {3,7}
//? step 4: act = 4, m = 7
//= step 4: map := {7->1}
//? step 5: act = 5, m = 2
//= step 5: map := {3->2}
//? step 6: act = 6, m = 5
//= step 6: pair := (1,5)
//? step 7: act = 7, m = 3
//= step 7: pair := (3,3)
//? step 8: act = 8, m = 3
//= step 8: deep := [{4->{(3,"a")}}]
//? step 9: act = 9, m = 3
//= step 9: at(3) := [1,3]
//? step 10: act = 10, m = 7
//= step 10: bag := <3>
//? step 11: act = 1, m = 4
//= step 11: R002
