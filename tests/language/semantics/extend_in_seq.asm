// the rules behind it in a sequence see the new element
asm extend_in_seq
import StandardLibrary
signature:
  abstract domain Order
  controlled n: Integer
definitions:
  main rule r_Main = seq extend Order with $a do skip  n := size(Order) endseq
//= step 1: Order + {order!1}, n := 1
//= step 2: Order + {order!2}, n := 2
