// an element of a subset is an element of the whole
asm domain_subset_constants
import StandardLibrary
signature:
  abstract domain Animal
  domain Cat subsetof Animal
  static rex: Animal
  static tom: Cat
  controlled s: Animal -> Boolean
definitions:
  main rule r_Main = forall $a in Animal do s($a) := true
//= step 1: s(rex) := true, s(tom) := true
