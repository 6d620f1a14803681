// the first case that is equal; without match undef
asm switch_term
import StandardLibrary
signature:
  controlled x: String
  controlled y: String
definitions:
  main rule r_Main = par
    x := switch 2 case 1: "one" case 2: "two" otherwise "many" endswitch
    y := switch 3 case 1: "one" endswitch
  endpar
//= step 1: x := "two", y := undef
