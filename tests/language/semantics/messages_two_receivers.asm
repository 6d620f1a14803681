// who finds one of two messages is ready: an agent is blocked only where none was there for it
asm messages_two_receivers
import StandardLibrary
import CommonBehavior
signature:
  domain Peer subsetof Agent
  static a: Peer
  static b: Peer
  controlled left: Integer
  controlled right: Integer
definitions:
  main rule r_Main =
    par
      program(a)
      program(b)
    endpar
  rule r_peer =
    if self = a then
      par
        r_wreceive[b, "left", left]
        r_wreceive[b, "right", right]
      endpar
    else
      r_wsend[a, "right", 5]
    endif
default init s0:
  agent Peer: r_peer[]
//= step 1: b -> a: right(5), status(a) := BLOCKED
//= step 2: b -> a: right(5), right := 5, status(a) := READY
