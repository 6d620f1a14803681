// Messages between agents, and between a specification and the services around it (SCA-ASM).
//
//     r_wsend[planner, "plan", goal]                          // send, and go on
//     r_wreceive[client(self), "r_drive(Agent,Goal)", goal]   // take the next message
//     r_wreply[client(self), "r_drive(Agent,Goal)", true]     // answer it
//     r_wsendreceive[planner, "plan", goal, path]             // send, and poll until the reply is there
//     r_wcall[planner, "plan", goal, 2000, path]              // likewise, for 2000 ms at most
//     r_wcancel[planner, "plan"]                              // wait for it no longer
//
// Messages wait outside the state: any number can be sent in a step, and none hides another. What is
// sent in a step arrives with the next one at the earliest. A step sees one message of each sender
// and operation, the oldest; a reply goes to the request that was received longest ago.
module CommonBehavior

import StandardLibrary

export *

signature:
	domain CommunicationChannel subsetof Agent
	domain Clock subsetof Agent
	enum domain Status = {INIT | READY | BLOCKED | EXITED | EXCEPTION | COMPENSATION}
	enum domain CommunicatorStatus = {AVAILABLE | UNAVAILABLE | RESET}
	// why a call ended without a reply
	enum domain CallFault = {CALL_TIMEOUT | CALL_UNAVAILABLE | CALL_FAILED | CALL_CANCELLED}

	// what an agent can do: one that is blocked waits for a message, and sends none
	controlled status: Agent -> Status
	// the channel all messages go through, and the clock
	static communicator: CommunicationChannel
	static clock: Clock
	// whether messages go out: the state of the broker
	monitored communicatorStatus: CommunicationChannel -> CommunicatorStatus
	// milliseconds
	monitored time: Clock -> Integer

	// the operation of the oldest message that an agent has not received
	monitored nextRequest: Agent -> String
	// arrived(a, b, op): what the oldest message from b to a with this operation says
	monitored arrived: Prod(Agent, Agent, String) -> Any
	// answered(a, b, op): the reply to the oldest call of a to b
	monitored answered: Prod(Agent, Agent, String) -> Any
	// calling(a, b, op): a waits for a reply of b
	monitored calling: Prod(Agent, Agent, String) -> Boolean
	// why the last call of an operation failed, until it is made again
	monitored callFault: Prod(Agent, String) -> CallFault
	// whether the last message with this operation could not be sent
	monitored sendFault: Prod(Agent, String) -> Boolean

	// what handles an exception of an agent, or compensates an activity, by name
	controlled exceptionHandler: Prod(Agent, String) -> Rule(Agent)
	controlled compensationHandler: Prod(Agent, String) -> Rule(Agent)
	controlled exceptionSubject: Agent -> String
	// the activities of an agent that can be compensated, the last one first
	controlled toCompensate: Prod(Agent, String) -> Seq(String)

	// whether an agent can send: it did not end, fail or block
	derived canSend: Agent -> Boolean

definitions:
	function canSend($a in Agent) =
		isUndef(status($a)) or status($a) = READY or status($a) = INIT

	// ---- what the machine does itself; the bodies are not used --------------------------------

	macro rule r_actSend($self in Agent, $to in Agent, $operation in String, $data in Any) = skip
	macro rule r_actCall(
		$self in Agent,
		$to in Agent,
		$operation in String,
		$data in Any,
		$ms in Integer
	) =
		skip
	macro rule r_actReply($self in Agent, $to in Agent, $operation in String, $data in Any) = skip
	macro rule r_actTake($self in Agent, $from in Agent, $operation in String) = skip
	macro rule r_actAnswer($self in Agent, $from in Agent, $operation in String) = skip
	macro rule r_actWait($self in Agent) = skip
	macro rule r_actCancel($self in Agent, $to in Agent, $operation in String) = skip

	// ---- messages -----------------------------------------------------------------------------

	macro rule r_wsend($to in Agent, $operation in String, $data in Any) =
		if isDef($data) and canSend(self) then
			r_actSend[self, $to, $operation, $data]
		endif

	macro rule r_wsend($to in Agent, $operation in String) =
		if canSend(self) then
			r_actSend[self, $to, $operation, true]
		endif

	macro rule r_wreceive($from in Agent, $operation in String, $data in Any) =
		let ($message = arrived(self, $from, $operation)) in
			if isDef($message) then
				par
					$data := $message
					r_actTake[self, $from, $operation]
				endpar
			else
				r_actWait[self]
			endif
		endlet

	macro rule r_wreceive($from in Agent, $operation in String) =
		if isDef(arrived(self, $from, $operation)) then
			r_actTake[self, $from, $operation]
		else
			r_actWait[self]
		endif

	macro rule r_wreply($to in Agent, $operation in String, $data in Any) =
		if isDef($data) and canSend(self) then
			r_actReply[self, $to, $operation, $data]
		endif

	// what older specifications write
	macro rule r_wreplay($to in Agent, $operation in String, $data in Any) =
		r_wreply[$to, $operation, $data]

	// ---- calls --------------------------------------------------------------------------------

	macro rule r_poll($to in Agent, $operation in String, $reply in Any) =
		let ($answer = answered(self, $to, $operation)) in
			if isDef($answer) then
				par
					$reply := $answer
					r_actAnswer[self, $to, $operation]
				endpar
			endif
		endlet

	// called once while the reply is undef: set it to undef to call again
	macro rule r_wcall(
		$to in Agent,
		$operation in String,
		$data in Any,
		$ms in Integer,
		$reply in Any
	) =
		if isUndef($reply) then
			if calling(self, $to, $operation) or isDef(answered(self, $to, $operation)) then
				r_poll[$to, $operation, $reply]
			else
				if isDef($data) and isUndef(callFault(self, $operation)) then
					r_actCall[self, $to, $operation, $data, $ms]
				endif
			endif
		endif

	macro rule r_wsendreceive($to in Agent, $operation in String, $data in Any, $reply in Any) =
		r_wcall[$to, $operation, $data, 0, $reply]

	macro rule r_wsendreceive($to in Agent, $operation in String, $reply in Any) =
		r_wcall[$to, $operation, true, 0, $reply]

	// forgets the calls that wait, and why one failed
	macro rule r_wcancel($to in Agent, $operation in String) =
		r_actCancel[self, $to, $operation]

	// ---- faults and compensation --------------------------------------------------------------

	macro rule r_raiseException($a in Agent, $handler in String, $subject in String) =
		par
			status($a) := EXCEPTION
			exceptionSubject($a) := $subject
			if isDef(exceptionHandler($a, $handler)) then
				exceptionHandler($a, $handler)[$a]
			endif
		endpar

	macro rule r_compensate($a in Agent, $handler in String) =
		par
			status($a) := COMPENSATION
			if isDef(compensationHandler($a, $handler)) then
				compensationHandler($a, $handler)[$a]
			endif
		endpar

	macro rule r_compensateAll($a in Agent, $activities in String) =
		while isDef(toCompensate($a, $activities)) and length(toCompensate($a, $activities)) > 0 do
			seq
				r_compensate[$a, first(toCompensate($a, $activities))]
				toCompensate($a, $activities) := tail(toCompensate($a, $activities))
			endseq

	macro rule r_exit($a in Agent) =
		status($a) := EXITED

	// ---- delivery and time are the machine's: these do nothing ---------------------------------

	macro rule r_CommunicatorProgram = skip
	macro rule r_ClockProgram = skip
	macro rule r_init($channel in CommunicationChannel) = skip
