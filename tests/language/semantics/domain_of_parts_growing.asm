// elements that a rule adds are parts of values at once; so are those of its supersets
asm domain_of_parts_growing
import StandardLibrary
signature:
  abstract domain Item
  domain Box subsetof Item
  domain Crate subsetof Item
  static b1: Box
  static g1: Crate
  monitored act: Integer
  controlled boxes: Seq(Box)
  controlled items: Powerset(Item)
  controlled other: Box -> Prod(Box, Boolean)
definitions:
  main rule r_Main = switch act
    case 1: boxes := [b1]
    case 2: extend Box with $b do par boxes := [$b, b1] items := {$b, g1} endpar
    case 3: forall $b in Box with true do other($b) := ($b, true)
  endswitch
//? step 1: act = 1
//= step 1: boxes := [b1]
//? step 2: act = 2
//= step 2: Box + {box!1}, boxes := [box!1,b1], items := {box!1,g1}
//? step 3: act = 3
//= step 3: other(b1) := (b1,true), other(box!1) := (box!1,true)
