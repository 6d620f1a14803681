// elements in any order, as often as they come
asm bags
import StandardLibrary
signature:
  controlled s: Bag(Integer)
  controlled b: Boolean
definitions:
  main rule r_Main = par s := <2, 1, 2>  b := <1, 2> = <2, 1> endpar
//= step 1: b := true, s := <1,2,2>
