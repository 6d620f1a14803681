asm too_wide
import StandardLibrary
signature:
  abstract domain Animal
  domain Dog subsetof Animal
  static cow: Animal
  controlled barks: Dog -> Boolean
definitions:
  main rule r_Main = forall $a in Animal with true do barks($a) := true  //~ W028
