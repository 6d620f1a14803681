// a new element is one of the domain it is taken for, also where it is written in the same step
asm extend_subset_written
import StandardLibrary
signature:
  abstract domain Thing
  domain Robot subsetof Thing
  controlled current: Robot
definitions:
  main rule r_Main = extend Robot with $r do current := $r
//= step 1: Robot + {robot!1}, current := robot!1
