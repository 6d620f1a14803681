// the element outside its domain is named, as in a plain codomain
asm part_outside
import StandardLibrary
signature:
  domain Few subsetof Integer
  controlled n: Few
  controlled bag: Bag(Few)
definitions:
  domain Few = {3, 5, 7}
  main rule r_Main = bag := <3, 4>  //~ R002
