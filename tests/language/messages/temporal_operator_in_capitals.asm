// operators of temporal logic in the notation of other tools
asm temporal_operator_in_capitals
import StandardLibrary
import CTLLibrary
signature:
  controlled isOn: Boolean
definitions:
  CTLSPEC AG(isOn)  //~ A005 L058
  CTLSPEC always(isOn)  //~ A001
  LTLSPEC G(isOn)  //~ A005 L058
  invariant inv_on over isOn: G(isOn)  //~ A005 L058
  main rule r_Main = isOn := not isOn
default init s0:
  function isOn = true
